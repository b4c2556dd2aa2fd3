"""What a closed form says of a branch over an interval of the redundancy parameter."""

EMPTY, REGULAR, FOLDED, SINGULAR, MERGED = 0, 1, 2, 3, 4
