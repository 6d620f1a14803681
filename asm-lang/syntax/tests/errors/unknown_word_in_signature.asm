asm unknown_word_in_signature
signature:
  controled a: Integer //~ L033
  controlled b: Integer
definitions:
