"""The report's sections: results in, words and table cells out; the templates only lay out."""
