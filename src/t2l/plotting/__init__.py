"""What figures are drawn with: one style, and heatmaps over a grid of cells."""
