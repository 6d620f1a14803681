asm unknown_characters
signature:
definitions:
  main rule r_Main = a := # 1 //~ L001
