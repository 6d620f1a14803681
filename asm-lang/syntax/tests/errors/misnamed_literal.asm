asm misnamed_literal
signature:
  enum domain Color = {red, GREEN} //~ L056
definitions:
