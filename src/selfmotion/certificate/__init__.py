"""Lower bounds on the cost of every continuous motion, and proofs that there is none, from cells and a convex cost."""
