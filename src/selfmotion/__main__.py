"""``python -m selfmotion``."""

from selfmotion.cli import main

main()
