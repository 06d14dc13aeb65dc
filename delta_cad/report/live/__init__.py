"""The live page: the machine in a browser, its handle dragged, its lengths changed."""
