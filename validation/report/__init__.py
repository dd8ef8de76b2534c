"""Pages, tables, figures and words; knows neither scene nor study."""
