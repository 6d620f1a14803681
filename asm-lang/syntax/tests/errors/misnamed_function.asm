asm misnamed_function
signature:
  controlled Speed: Integer //~ L036
definitions:
