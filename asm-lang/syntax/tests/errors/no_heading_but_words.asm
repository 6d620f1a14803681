this is no specification //~ L021
