"""`python -m gaitopt`."""

from gaitopt.cli import main

if __name__ == "__main__":
    main()
