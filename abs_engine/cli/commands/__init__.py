"""The commands, one module each: the function of a module's name is the command of that name."""
