asm comment_of_another_language
signature:
  controlled speed: Integer
definitions:
  main rule r_Main = skip
# //~ L001
