"""The commands of the command line. A file has one command, or a few that belong together."""
