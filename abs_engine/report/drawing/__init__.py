"""One toolkit of drawing for pages, figures and inspection pictures."""
