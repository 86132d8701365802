"""What a person looks at: figures, the walking robot, tables. No numerical decisions."""
