"""The common floor of the three packages: console, files that appear whole, compiled code, style of pictures."""
