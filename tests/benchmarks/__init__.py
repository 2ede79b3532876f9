"""What it costs: `make bench` prints the tables that the README quotes."""
