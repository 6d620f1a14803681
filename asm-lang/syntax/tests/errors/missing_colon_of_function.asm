asm missing_colon_of_function
signature:
  controlled a Integer //~ L032
  controlled b: Integer
definitions:
