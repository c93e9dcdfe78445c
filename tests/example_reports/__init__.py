"""The example reports in reports/, their index page and README's pictures of them."""
