"""What `design` and `front --machines` write about machines: texts, pages, files."""
