"""Charts under the vehicle: files of the user, read once, and served to the page. No other host."""
