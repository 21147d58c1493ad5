"""One HTML file that shows results beside their ground truth; see `page.report_page`."""
