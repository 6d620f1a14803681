asm product_sign
signature:
  static distance: Position * Position -> Integer //~ L059
definitions:
