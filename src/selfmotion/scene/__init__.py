"""What stands around an arm: obstacles, and how far they are."""
