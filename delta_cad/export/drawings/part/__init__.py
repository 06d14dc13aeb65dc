"""The content of a part's drawing: its faces, holes, coordinates and sizes."""
