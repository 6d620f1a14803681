module unseparated_names
export f g //~ L058
signature:
definitions:
