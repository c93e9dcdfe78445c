"""x"""
def write_picture(results, path): pass
