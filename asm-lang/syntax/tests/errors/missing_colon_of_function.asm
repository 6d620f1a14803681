asm missing_colon_of_function
signature:
  controlled a Integer //~ L052
  controlled b: Integer
definitions:
