asm misnamed_function
signature:
  controlled Speed: Integer //~ L056
definitions:
