"""The controller in C99, translated from the compiled Python tick so that each formula exists once."""
