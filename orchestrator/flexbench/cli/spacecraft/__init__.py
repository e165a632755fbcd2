"""Commands about a spacecraft's file: a start to change, and what a spacecraft is before it is built."""
