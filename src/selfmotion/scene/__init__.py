"""What stands around an arm, and the shapes of its links: obstacles, how far they are, and what must keep clear of what."""
