"""Compile a Mission to a Chart, and report all errors to its author."""
