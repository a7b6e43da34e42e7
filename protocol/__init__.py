"""What bytes mean. Sans-IO and clockless: no sockets, no ports, no time of its own."""
