"""What a design's machine must consist of, counted from its dimensions apart from the code that assembles it."""
