"""report.html: what a build came to, as one page that opens from disk and asks nothing of any other place."""
