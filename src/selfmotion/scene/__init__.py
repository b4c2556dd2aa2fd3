"""What is around an arm, and the shapes of its links."""
