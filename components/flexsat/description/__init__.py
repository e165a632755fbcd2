"""What a spacecraft is made of: frozen classes, the TOML files that state them, and the built-in spacecraft."""
