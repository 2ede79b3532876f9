"""The commands behind the command line, one a file: files in, files and tables out."""
