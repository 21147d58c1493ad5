"""From points and pictures to faces and their appearance; nothing is filmed here."""
