"""The capstan's cable: its way over sector and pinion, and where it ends."""
