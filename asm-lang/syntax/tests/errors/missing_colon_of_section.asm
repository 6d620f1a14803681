asm missing_colon_of_section
signature
  controlled a: Integer //~ L052
definitions:
