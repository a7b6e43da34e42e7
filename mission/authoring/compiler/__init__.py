"""Mission -> Chart, and everything an author is told on the way."""
