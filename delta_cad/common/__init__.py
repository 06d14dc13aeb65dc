"""What the three packages share: console, files that appear whole, compiled code, style of pictures."""
