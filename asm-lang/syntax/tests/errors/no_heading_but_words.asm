this is no specification //~ L012
