"""The commands of the command line, by what they are for; importing them imports nothing heavy."""
