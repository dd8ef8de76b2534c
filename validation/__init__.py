"""The comparison of theory and simulation: the only package that knows both."""

from validation.environment import settle

settle()
