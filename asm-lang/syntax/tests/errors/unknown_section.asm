asm unknown_section
signature:
defintions: //~ L053
  main rule r_Main = skip
