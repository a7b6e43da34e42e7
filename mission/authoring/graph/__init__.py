"""The state graph of a mission, drawn and exported from its chart."""
