"""The command line of the master, and options that other command lines share."""
