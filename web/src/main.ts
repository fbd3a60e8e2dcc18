// The page begins.
import './app/storage'
import { createPinia } from 'pinia'
import { createApp } from 'vue'
import App from './app/App.vue'
import { makeRouter } from './app/router'
import './ui/base.css'

createApp(App).use(createPinia()).use(makeRouter()).mount('#app')
