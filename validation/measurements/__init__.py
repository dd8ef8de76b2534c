"""What studies read off many surfaces, with its uncertainty."""
