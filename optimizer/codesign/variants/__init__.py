"""The same task with other limits, and the same candidate with other lengths: what each comes to."""
