"""`python -m validation.cli`: the command `fem-contact`."""

from validation.cli.commands import main

if __name__ == "__main__":
    main()
