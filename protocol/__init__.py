"""Codecs: bytes to messages and back. Sans-IO: no sockets, no serial ports, no clock."""
