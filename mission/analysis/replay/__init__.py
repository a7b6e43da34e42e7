"""The recorded inputs fed to the same drive, and the first difference."""
