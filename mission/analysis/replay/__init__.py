"""The recorded inputs fed to the same runtime, and the first difference."""
