"""What plot.py draws with."""
