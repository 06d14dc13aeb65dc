"""What has to be told of a part: its faces, holes, coordinates and sizes."""
